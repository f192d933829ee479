"""Small HDF5 files as h5py 3.16 and hdf5storage 0.2 wrote them, packed."""

import base64
import zlib

PACKED = {
    "plain.h5": (
        "c-"
        "rgqaB<`1lHy_j0S*oZ76t(ZWbhvf+&EDAF!=;1%?PDCp!5nRm^dR?P68?}2sIyFT}Y6tD@gT!Gyt>5fCWNxFpPqc2s~UJ13+{Hl&=A$P"
        "cWgXE6dL*NlZ_T&klp|)AEawQ-"
        "O4Hera9_QaUvt(q2XeR)`)(7$1_785to0tWb3@ni(h$k`Yv}ho)5r1`}=ulmE;xbsS)MCMG6ENP32t$IJ*z+8Sss=onP-"
        "5bWpg!U*)G0?c)6_|?PmeFZCib+CM`z&tY2Ga~~VTDpS7J0m1nz|$!!TKS5Z&g2;&MWX_PI0u7xJp-"
        "Y1rU4CV5fu0E!0ZRQivtKt^D;|{fqY@0ZYCuAbN%2slFH#hYCaPHD;3~`xQ_u^ui*B#4b<OUXf{t6EnFEM*hA<KQ2Gay1{PjmzyhQj>>"
        ">OHkeDNob_7Qg6EG@R09k!SJO"
    ),
    "chunks.h5": (
        "c-rlmzi-n(6vyA49mi>t$`z%p5Fr*4s0&gk9T-3a6r)aU#E;Sm98!lMLQ}O4WI-?j1N;FjOehm#M2cWwKp-K+zre--BZw{de0Oegs;f3"
        "-h}8GV@brGfce39(Pv1P5FJ8=y92x<JX@U+G^wJf~%=G&*?+QzVeJpI7$~Xyg(;_}DuCLZzx#T#kx~m}9$?M#jfb2)+o%1DTmxV9d5kA"
        "rWx_gbfU%uttxU<ClYGb|P1-8;?uKGQFn&08N1PuNiB7NS;gz!K@)Jdxad6pTs&xu|wz}zUzbv0RMhIy*d@B*Vy3VkB-"
        "G|Us&s5PtAx)=335%CqTS}*$^=+S!oJO#CWrRJ@lnw95-?^C0+m5`V2J3je=p2OvZ#Ucq-wT1uV$oBQ}+_w*IUne(aYx|?0+53*&NA-P"
        "oAf~>Z;a29Awug?A*OmO&OuugczE2SZK@eovX<e_lg-"
        "6NU&tD{&rHfY|=w%+trT>h9{+hJhYqk@HVA4niKkqNW`I7yXVj<V9xo_?VL&HY`@0O1}m$9`q9q4C5JBO_oQEVlsdkP=&(?_52n9inFd"
        "c5$e6#6#}HnkeF7v3+0emU4(8WJbZbc*<x5ClOG<iA27IiL=e6Iy@`QzlG3jOuo$L+Q~z2G*h8PHsvUkvx$WN*>eM%;3{pz3p!>9fR;f"
        "sn^|I*qMGZ5p(~(3;kmvMnCzj<W>D7HMX^WqGM|!2!bHU5YJD${U6T?ORbcg6|8~gCc5{z>2GdxWa$}OPVeb{#LZ7uOnp|&KUU2AbVA9"
        "ibJ5wD`H5m{A_#&Y$k6f+<AcVz"
    ),
    "latest.h5": (
        "c-rgqaB<`1lHy|K;9!7(|4`rt6*7Q|mxap)`g^zpF)>sy2_Y+l0WKy6Mg|5pQ3fEzRhFMql9-+vpB=Uts-"
        "H~&B*B`NUzD7>pAkhYIlnZo<TMjhp*RCBaO-"
        "91BCrz}85kKw7#Nrs85vojaxj`%gn>~|!JYx)dIts*ZU&S8%s_dd>zKJXfG%fdgi11Kzzp8NFyz3`y*xYNVW9#H3s7L7g#{zlu#snA0r"
        "M0X#5owm>lskPMgtl)B2Yb|LLlYnam^zORLj5y3`n44X<lYYF@rGBHc%9TaIPOiCLO~<$W%~<V7lO8U=-"
        "klIFErr0L9NXP(O3Q4BWvmWI@c*<kbwLU=)mkQ9vAcU=N``K<OV)8d!UR0Sl0Bu!ry)Kw^$S+7Vp8Fac`;7623QRU7"
    ),
    "user.h5": (
        "c-"
        "rlm&o2W(6vyApwz^u9`dKYukK)ur??_teQi6zsFw|B>sj!va#LbVZe?iiti^Q3WKf=Y$#Z{ct&d!XsV#TjWwC}TrmpAV_Guhd<lgS$Zq"
        ">(vF#>ZOy5x?W;I(Q%`0#ul?WN@g~SN)l^MA}1XOH{QJC)Oj|+vNCfb+gln1Xq{epyr8sgw^qrH6+Qz=oGi}(jS!ehSuu#@;PgH&0N};"
        "6MiPYlQwOe&KI_<syvN;a$W*Wq7PBN$Yer9gIDU5)$BNrv>C%PS4SWgfLK{mI^Bs=jXDDaz;Jx>I==4wF{@@Kw``dp)81|s^J<h9y_G4"
        "eeh2m^-(e;-87KBz8q&Y-|5&g7`%>4(I`txk))@KB_dD{=e%I@wFSXYCUcmhjK@bE%>Yd_Zn!$nZksaS@r_bap+-"
        "G#2Xs~eM@$*pje2uYf#<H-|G;TcT5SgG?Jiyp0TVWYS_>nn)>xdu-f*}710={q7p$23P$$*d!q5W6gkLysE-IXa-"
        "7+Pdyj@Qj}`zdU#Tf4U3K}1Pe)!#N#sz>x&>)}>E3A^a8UFs(uOf3XK5Co~?^V3)F@q&&t*sQL?gTHlddK#!qRdsur{nPbuJ3qC%=x<%"
        "lPZU!NK@bE%>XsM6h?Yw"
    ),
    "soft.h5": (
        "c-"
        "rgqaB<`1lHy_j0S*oZ76t(ZWbhvf+&EDAF!=;1%?PDCp!5nRm^dR?P68?}2sIyFT}Y6tD@gT!Gyt>5fCWNxFpPqc2s~UJ13+{Hly3p0P"
        "cWgXE6dL*NlZ_T&klp|)AEawQ-"
        "O4Hera9_kWS3WOe_Y{`cMg2x>dkoFCzmhL=7X14@t?4j1U1<s5%(U43r1S2rAe^)2ai52{(hue`c6E4zN5E6B8pOJwwc6W`ree4Kx>Y4"
        "61kt_VagP1eOvSXypSe8Vu0X!@{+L4Zpdt@}YtizdBg{S7096>6wv%4J}<kLX;7bEa2&q6|H>5OlR^8EYOe^=U@=8XCRc$G@wB!g5n+?"
        "nEgO^aR6ayUS<g>p9lkWGa=cZ>j%$~R1ObP^O*oxsQ@R$eGJfg1-"
        "HL#p#J7Uvw6a3;mYv99zuVB(m$Xyu<!x{79ibV58*d}#2kUNBRHCvfKkB$071b~*8"
    ),
    "external.h5": (
        "c-rk(y-ve05I*OR5I_n7QN%*VPP9YWklIQu>QoRQ#0IDe1Obf%DPp5z*%)~Q9)-u?5g6HuW8ak|lmZe%QT=83boTi--"
        "`VH;Ms0J>S#cnSZG!<WB+*9%ZrY~$BV>l$Lw?ez+!l4qSngu~k5lRPdpq@d?A_0R#wi+-ZBUp*H0ssum=Dm-BR^|tznkzPIzIIe&-"
        "bN$5?-"
        "}@&aJT1juJX8{%~9drfkE=mP%$!7MSQqtn>P~X5K5KRx41Nfl^;5KN%02rZK5!*`Llx+WE{3dSmq;cAHx@##ial?5xrL6!*90Xg`W;Po"
        "E4uGq5tclK-"
        "7aSqyY)X3p2oI$H&KG<uM;A$JGg=`4?1y_lNMERE0SW%IAoK8vooy}(;*iSaL+gNXd&{rGL1xx&?*mh%I=SH52N2Cm!5jQlW``k;G~D8"
        "O=U5K+T#N(a|Zu&@KZzv2iS9<MKD$*;(7$o%jUFgSP1((cA(RnAq>t;T<aq3$OI1qB5Kh5v*^ejuJol&4#ie}VJyq)H^`7Uhd}#SEjsz"
        "ghw)_))7MjJ04L3iR|6cn9hwX+Q"
    ),
    "external-latest.h5": (
        "c-rgqaB<`1lHy|K;9!7(|4`rt6*7Q|mxap)`g^zpF)>sy2_Y+l0WKy6Mg|5pQ3fEzRhFMql9-+vpB=Uts-"
        "H~&B*B`NUzD7>pAkhYIlnZo<TMjROaLf$of*Q`g*ghs_g{1F3D^mY42+B-3=B++jEt;M6)>7vgn>~|!JYx)dIts*ZU&S8K<%tR*D-"
        "T(0A0?^2$f{efEmAmVaS1>dwF)k!$JiZ7NEdD3kyc9VI$AL0_G_&h;uNA*E67ojRrJqM4);^g+R*D<C;en6en!JfCNgG=4F-"
        "?GYA8114SVS=lU^Z(lIQAOa)~KrVAbhMgdNU^MHvA#m_cSKXbth+`%wpLCn(R)&9;N-"
        "fW7%_~&q7%`eGFEfQm3&`&K%)(3O+GE5ot!P$^uzU4s!hEXsIM!^UM59}fI2PpjmN&{<8Fkk`F4fYUz14zsfNIQb-7bajWzybiI%3@*"
    ),
    "raw.h5": (
        "c-"
        "rgqaB<`1lHy_j0S*oZ76t(ZWbhvfHn5`dVe$!3nh{EOK<O1sFmXn(oCH){5NbZUx{x4OSCH!eXaHtU1`CAdU>F4>5qP*d27u@YC?A$eP"
        "cWgXD^5)=N-aU8M-K|^Wn^H3n8gU=LsBv$BSattst!go16{@lbsr;Aie&}TAU+cl6Ihs?K?BTZgys<g9O)ZoE(g?JW=2@fNI_GXK-"
        "YMXK+E?5EU4=AQ%jQd3lfWq%OUOz_VafE`4i?p1?JH-O%4D6<L5pP"
    ),
    "compound.h5": (
        "c-"
        "rgqaB<`1lHy_j0S*oZ76t(ZWbhvfCUBtgVe$!3nh{EOK<O1sFmXn(oCH){5NbZUx{x4OSCH!eXaHu90SkoYU>F4>5qP*d27u@YC?A$eP"
        "cWgXD?v+-"
        "9u(Tk$iNCQixI|$q+~`$hyW*49gJpXXaFk}V}iIbkw|+473`sD+kwG^o5AEiGXp~s1952{n_gC+2*@2wOiYXrGa&9}W`r3x0nHQzqTCt"
        "m=kEf_(J(hDFps9qQ7{Td0d)WXoLMpl"
    ),
    "huge.h5": (
        "c-"
        "rgqaB<`1lHy_j0S*oZ76t(ZWbhvfDp*nZF!=;1%?PDCp!5nRm^dR?P68?}2sIyFT}Y6tD@gT!Gyt>5fCWNxFpPqc2s~UJ13+{Hln+a#C"
        "zw#xRiLFu4+`yNWMG4s#R%g=QZgeWR6t<ql@~}fGf*BRBdA~xO{)$JCfp1r|Cu4mS%IP;c_wBiumRi*3Sd4X+<Xpjj!8*P%SkLrWq>Ao"
        "peV#%W+o<B)_B2;k{uH05)Z+C{w|DQS3-aS^Jv;62LJ%;(mvt"
    ),
    "chunk.h5": (
        "c-"
        "rgqaB<`1lHy_j0S*oZ76t(ZWbhvfDp*nZF!=;1%?PDCp!5nRm^dR?P68?}2sIyFT}Y6tD@gT!Gyt>5fCWNxFpPqc2s~UJ13+{Hln+a#C"
        "zw#xRiLFu4+`yNWMG4s#R%g=QZgeWMBoK8YQA6w%7bJC73`sD)q%l;o5AEiR2?f&6eQ2Y%mg-"
        "on?V80XM~&20nRZgscAWhC8-S1WDgXD*vrhs1kV}|zp^4_hXlIBL$IH}3nSQ-5TL+3nl{M+05jD?(*"
    ),
    "lzf.h5": (
        "c-"
        "rlmK}!Nb6vyAp?&hWmN|w<f_vq1scURExWKj{`GDIUXh0=&1@>t)(qaUG95PgPD9XodPW;3%hyQ{U5LP7R^B9AxocE%as?*4i6P%3Ok!"
        "<%8?m?r2D13x24Iz8^I{;IS@+IwjSRJ9Y)w;|i(a{S4-gS}#rM~@~@^JH|#nt=RAO2zyxw-"
        "xEjbcAO*9(UDlc8*W#M`wqQ-)LXd>de;K-B!n!r<rfgOJK>lhA7|3WI~(<L&hnqv3}kYw{kL9ZOBF-"
        "JJM8~Df+2K#Q+hu5+cTv1Kjd{4VpI%;qtUMh__x-&aY8=ZFp1rZi~u~{tx@*odW-Tmh|7YrpK%Mey}z@PA$OF{zpFZ=N<Xtc^9;ugXp+"
        "#06q^91VIpF(IH$&lGmJVFv0uY55ce>B4Aqy3y5w5^m0OKLXUkR&um^?M4436arY1eK@jAxzW+mW)}c~T09cSTA$jM<%~yv?xOE4&4)w"
        "V1P3>xp6<M+3^)r)wx~<dBCG%I=7}Q$^oR`%V>6!K;sD6_0jqT?tpnihl2tg18K^9p*&3cX(6QQwXN3Vc9x1Luwg+J@2Val7*cZym4mH"
        "i0PPvHRl^b(+-D5e&IAP9miEFZ24g_8"
    ),
    "heap.h5": (
        "c-rgqaB<`1lHy_j0S*oZ76t(ZWbhvf=1HOQVe$zK_<_HNOAr&!112RfkC_uHoF@!rh(IVcD9y#hzzAlnVi-"
        "~&%Vfc7Mg~@h;~_o(QW6lF5hB0}RSTn;f$|_3K?QpT4zP#=g9$f-"
        "$$w^;Iu5Wr6B85I01l{m%#2Xw3>s*z=onOCLcj3P7!41U@CX<U50vnz7!41U@K`V!9w^~)Vn~Ds4Z#C@2>k&{|A5lK5Cj7jhf#IZP&W!"
        "j!6+C7qhJ(_v_{s4(MBgqct~&#h463-"
        "4t8bmfsW2F>M=500x{y|M=u>*q3JL*LNmxCfPo$40pwve*qE9gG?ZY$4OE3nLjfm|wy_}Tgcz*=q~}S%#8%A+ZgmRrZ~+D@P#rf=Bt>J"
        "M2+R(cErLZ~YQd`5K&tp5s>IM$WlP^qaSH~jV$fqmwh=)iTou4j0dxu6O+pZH=l~;}PT5d$(kaBpje*tHVY)EG3ZRfEgI$4!27?xuxm4"
        "kuK0_v$xxP%tg&_pYbT)gNz)%NfniL640#YF62A1yQ43oi3=|vYWG3*61+0TA?#$XR-"
        "{(sQ)eY7$dbO0RxY;Z0lGT{jdk`CZW91@evFfJrLu)w&GlmaVgph*O7G$d`X!?=*d#sT9(l1q%oyy>G+Lf`Vz!^H_PR{#X<u8E$E@Hk~"
        "kHt>d(HY|*ALBnV!m>|3aO*YDAh6ysm1&ym&V1g`gL6dG)m>?@$&~!E%OppyOXa+0A8Clrjg60B(FhLHuphcX}Xl#-W0Q!cit^"
    ),
    "filled.h5": (
        "c-"
        "rgqaB<`1lHy_j0S*oZ76t(ZWbhvf1O!p}F!=;1%?PDCp!5nRm^dR?P68?}2sIyFT}Y6tD@gT!Gyt>5fCWNxFpPqc2s~UJ13+{HEImN!6"
        "HKV;%JOqc64O)Tv%?_#wEUvvR3M$4Uz%3}q*HSXN-"
        "B}ks|Epk85vk1Y8hdCNJ?g8gb1)g)xl_Hpgc%MP{AIWRvj2jxEW0TGsDzzfaRH(m>41H8DbtYBP?m7yQpJO#Y3>4zY8O<lu&@Vjt#$hx"
        "NijTtAmvf6|DHx!ScTX^UzMuj0|jO=?W53jF4mjPoJ!4<tt`7lV^YwjS39n91P<14205|1~dpoP~5`<vmfX#4j?Se%Pc7d@`ZuAnUL(y"
        "^@Ha~Du)ND`Ah(;RDcuWK3D?7?Qa{Xzq!zCo-"
        "kUtGCZ({&>x`m4=4>Ryug43NH^F+_zfU2M<DG8jwU8xRIrSO;3yacqhJ(_f>AKE+M)F7-@tnGgS&qN04>&1&j"
    ),
    "words.h5": (
        "c-rlmy-ve05XbF&fK`M@w@?@|cFfQ{K{Sv7Q3MQ(EC_}o1_nAZhBwF~@Cb~IJVHkvfsrk(>$^5Fr9^Ed8ufn5KejKnW8Wpw`6X^2ZPyw"
        "#CJ};J%wc&l;N2^hvHcp9gC?M_2G;XYn+x@I=wG+HJdYx2ooV1WzNJ(!VjYR2gEOgDP;P>L7)84$&_~dF&|A$<{gUHyW~+NRmPMf-bLi"
        "RfdYAK&XFKCIWoHjnmJLHy3y1_0JJRBfv2>;P;o`K@=EJvyhqK)*u4@W`{?<^6ai46=?iW{~XV137`1j0e`*T^ps(S&ngsip2S{Xd|#I"
        "Fp^uN-&!n=-A~dZ-BJ>hT!7{(sf^*UN?Vde&yt`{(tT{@v8$Yf)slIbssS$A_I0o(o8xvy<H2bh{6^`};feZ6XMQAP9mW2!bGpY9d0VU"
        "qLzh<=g#r9uV%sOlh;$68$^?^T&NHFNRq>%wxq1j{7rDsS<LWs|w7Mq0XO|Og&}M)Mk*Z)IO;5fbn4l^Y_R%34&M#pF#1z;T!)S;Qz!5"
        "2W{wLJO"
    ),
    "virtual.h5": (
        "c-rgqaB<`1lHy_j0S*oZ76t(ZWbhvf7$ng6P>=wn8KHCslwQFE6K4d=LA5goLd{247ZT*^3R3+a4Z!R%V1dva45MHq0uNWm01zDk<-"
        "=0x2_{r^WoYTqgF<^58Q36ZF~azel+4Ho5nzR?gVD@Dd60~tf;}{?Ixv`UGno8mhN<HK%QG=EF+$Qa#3wAwu%rz!R|v`l@#=LrvKbf}2"
        "1Pss`}w<oax^R-Dlm_x%~3E4hAMD(_V-"
        "~#Do|nNrY{3pL8_lxlB}O!l95`ZmthJlW|@)XK!6E}F92o3_@KIblVHX&B;^zMN5g&;jDk@x3P!;w7zLwX6pVsVFbYP&D4-Vr0Buw_4*"
    ),
    "matlab.mat": (
        "c-"
        "rk(&2G~`5MDcJG5L{PdT50>?6HSpIcXBAT$<1Z1&Nf12E;Ah#?Fswdn4Pa8lC{&gh$~KIPwS_xdq$1o334)kQP)bJeTqQ%+KyOGoEeLJ"
        "Fn``;WK3qw(6ay{gI*X!nT3jKDNy&9BTct<6;{Pbf_vtrML?ZZ5_F~2C-"
        "Fzo#6x?;|o}<z(TQFu2lC5u&8>Y=Fy8Xbb3SGM6jT!DpcSV0Y>7>7D(t$>63?4KJz#e3?vDpflRR>Y(`1l3XhrmDdhs?A1VJVvUwp`+o"
        "tmyRDX0|=S`#G@18}7*-"
        "_JkO9^EEB{duMw$I<w@jm5W#PGfgY`9*r>Yl$NW5>1ex!yHRx^5v;_j%ty13qqHj9md_$sU1?cL*2B#9Ac&qvMnp`Tq9?JfN{#1Enk|%"
        "~EW?6s(IPQ7F+&NeM7ZcI<@w$$=)-pZC7EL3`>Bv89|0(KtAlJkOCD*(V4gf1-"
        "ZMG#@Xcj<Y%tp_Aj+M}k)+RCaHhi*aM#pDsyURv#|c7w=<gVCsIybB^Hyo_J@H7>?G&98Z<EmZsarbYu-WQvxg4^l*8=!P7S|aw{cI&p"
        "y?&bzRRPwp=u_bo;uzr6Jo!Q%_!<$CEGL3i^R=&p?jD?5=Zi8lIdPI^gW)c)KBg^Sr&lA!gN|e;BNNjmfLHd|JD8UNvL#s(qupV&zAS@"
        "i)OaL)OHb)=xS3mgg$uCHRghzL}VOTMgeok+=N4djF$BMFlJ28ItcI1KHrW@Jw@Zy`e9~`~N6Fl*)}Px2x$rtm&-"
        "!OOgAC#QBx|__#=g&wY=p^|u4Uzf=B$a(X!+T??<Xd6{xZxmp{82{6GJI6z36x`Yx+D4~QB`bTM5{~CQ)3k&*JfqTKm_pcwak%#!5_pf"
        "{(d4{n;^!)w)m4C+=crfxrZ{5ENEA+3wI`>ZtCNO{"
    ),
}


def unpacked(name):
    """The bytes of a file."""
    return zlib.decompress(base64.b85decode(PACKED[name]))
